// The list of keys.

import { word } from "../../languages/words";

export const help = {
  title: word("app.help.title"),
  keys: [
    ["1 – 4", word("app.help.keys.1.2")],
    [word("app.help.keys.2.1"), word("app.help.keys.2.2")],
    [word("app.help.keys.3.1"), word("app.help.keys.3.2")],
    [word("app.help.keys.4.1"), word("app.help.keys.4.2")],
    ["+ · −", word("app.help.keys.5.2")],
    [word("app.help.keys.6.1"), word("app.help.keys.6.2")],
    [word("app.help.keys.7.1"), word("app.help.keys.7.2")],
    [word("app.help.keys.8.1"), word("app.help.keys.8.2")],
    [word("app.help.keys.9.1"), word("app.help.keys.9.2")],
    [word("app.help.keys.10.1"), word("app.help.keys.10.2")],
    [word("app.help.keys.11.1"), word("app.help.keys.11.2")],
    [word("app.help.keys.12.1"), word("app.help.keys.12.2")],
    [word("app.help.keys.13.1"), word("app.help.keys.13.2")],
    [word("app.help.keys.14.1"), word("app.help.keys.14.2")],
    [word("app.help.keys.15.1"), word("app.help.keys.15.2")],
    [word("app.help.keys.16.1"), word("app.help.keys.16.2")],
    [word("app.help.keys.17.1"), word("app.help.keys.17.2")],
    ["?", word("app.help.keys.18.2")],
  ],
  mouse: [
    [word("app.help.mouse.1.1"), word("app.help.mouse.1.2")],
    [word("app.help.mouse.2.1"), word("app.help.mouse.2.2")],
    [word("app.help.mouse.3.1"), word("app.help.mouse.3.2")],
    [word("app.help.mouse.4.1"), word("app.help.mouse.4.2")],
    [word("app.help.mouse.5.1"), word("app.help.mouse.5.2")],
    [word("app.help.mouse.6.1"), word("app.help.mouse.6.2")],
    [word("app.help.mouse.7.1"), word("app.help.mouse.7.2")],
  ],
};
