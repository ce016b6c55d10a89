// Some addresses are for visitors of a shared result or a second screen, all others are the page itself; each loads only what it needs.
import { passSecretOn } from "./share/visitor/secret";

const isSecondScreen = (): boolean => /^#projector(&|$)/.test(location.hash);

if (!/^\/s(\/|$)/.test(location.pathname)) {
  const isSecond = isSecondScreen();
  addEventListener("hashchange", () => isSecondScreen() !== isSecond && location.reload());
  if (isSecond) void import("./projector/main");
  else void import("./app/main");
} else if (!passSecretOn(window)) void import("./share/visitor/main");
