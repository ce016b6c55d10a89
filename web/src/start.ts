// One address is for visitors of a shared result, all others are the page itself; each loads only what it needs.
void (location.pathname === "/s" ? import("./share/visitor/main") : import("./app/main"));
