// Some addresses are for visitors of a shared result, all others are the page itself; each loads only what it needs.
import { passSecretOn } from "./share/visitor/secret";

if (!/^\/s(\/|$)/.test(location.pathname)) void import("./app/main");
else if (!passSecretOn(window)) void import("./share/visitor/main");
