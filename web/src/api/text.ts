// What went wrong between page and service, and what to do.

export const noService = "The service does not answer. Check that “breastrig serve” is running, then try again.";
export const refused = (status: number): string => `The service refused this (HTTP ${status}). Try again, or look at its log.`;
export const notTaken = (sentence: string): string => `The service did not take what this page sent (${sentence}). Reload the page and try again; nothing that is saved is lost.`;
export const tooLarge = "The file is larger than this service accepts.";
export const unexpected = (message: string): string => `Something unexpected happened in the page (${message}). Your landmarks are kept.`;
