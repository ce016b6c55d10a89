// Some addresses are for visitors of a shared result, all others are the page itself; each loads only what it needs.
import { passSecretOn } from "./share/secret";

if (!/^\/s(\/|$)/.test(location.pathname)) void import("./main");
else if (!passSecretOn(window)) void import("./share/main");
