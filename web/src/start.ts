// Some addresses are for visitors of a shared result, all others are the page itself; each loads only what it needs.
void (/^\/s(\/|$)/.test(location.pathname) ? import("./share/main") : import("./main"));
