// Lets the browser answer who uses the page, between two steps of long work.

/** Ends the task that runs; what is awaited goes on in another one, after the input and the pictures that wait. */
export const nextTask = (): Promise<void> =>
  new Promise((go) => {
    const { port1, port2 } = new MessageChannel(); // no timer: those of pages in the background wait a second
    port1.onmessage = () => {
      port1.close();
      go();
    };
    port2.postMessage(null);
  });
