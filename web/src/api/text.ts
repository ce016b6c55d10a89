// What went wrong between page and service, and what to do.

import { word } from "../languages/words";

export const noService = word("api.noService");
export const refused = (status: number): string => word("api.refused", { status });
export const notTaken = (sentence: string): string => word("api.notTaken", { sentence });
export const tooLarge = word("api.tooLarge");
export const unexpected = (message: string): string => word("api.unexpected", { message });
