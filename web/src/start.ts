// Some addresses are for visitors of a shared result, all others are the page itself; each loads only what it needs.
import { openLanguage } from "./languages/language";
import { passSecretOn } from "./share/visitor/secret";

const isVisit = /^\/s(\/|$)/.test(location.pathname);
if (!isVisit || !passSecretOn(window)) void openLanguage().then(() => (isVisit ? import("./share/visitor/main") : import("./app/main")));
