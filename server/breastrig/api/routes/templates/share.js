// Opens a share link: passes the secret on to an address without it, in the tab's name, so that no history lists it; posts
// it there once, then shows what the link shows at an address of its own.
"use strict";
const part = (id) => document.getElementById(id);
const FILES = [
  ["fitted_glb", "fitted.glb", "posed rig with drawing"],
  ["fitted_ply", "fitted.ply", "posed model"],
  ["drawing", "drawing.json", "lines on the scan"],
  ["result", "result.json", "numbers and parameters"],
  ["mesh", "scan.glb", "the scan"],
];

function say(sentence) {
  part("note").textContent = sentence;
  part("note").hidden = sentence === "";
}

async function ask(path, body) {
  const request = body ? { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) } : {};
  const answer = await fetch(path, request);
  const content = await answer.json();
  if (!answer.ok) throw Object.assign(new Error(content.detail), { status: answer.status });
  return content;
}

function row(name, value) {
  const term = document.createElement("dt");
  const text = document.createElement("dd");
  term.textContent = name;
  text.textContent = value;
  return [term, text];
}

async function show(shared) {
  history.replaceState(null, "", `/s/${shared.id}`);
  opened = shared;
  const result = await ask(shared.links.result);
  const mm = (value) => (value === null || value === undefined ? "not known" : `${value.toFixed(2)} mm`);
  part("numbers").replaceChildren(
    ...row("Stance", result.stance),
    ...row("Model to scan, mean", mm(result.surface_distance_mm?.mean)),
    ...row("Landmarks, mean", mm(result.landmark_distance_mm?.mean)),
  );
  const items = FILES.filter(([key]) => shared.links[key]).map(([key, name, what]) => {
    const link = document.createElement("a");
    link.href = shared.links[key];
    link.download = name;
    link.textContent = name;
    const item = document.createElement("li");
    item.append(link, ` ${what}`);
    return item;
  });
  part("files").replaceChildren(...items);
  part("until").textContent = `The link works until ${new Date(shared.expires_at).toLocaleString()}.`;
  part("result").hidden = false;
  part("ask").hidden = true;
  say("");
}

const MARK = "breastrig-link:";
const token = name.startsWith(MARK) ? name.slice(MARK.length) : "";
if (token) name = "";
const id = location.pathname.split("/")[2] ?? "";
let opened = null;
let asksPasscode = false;

function passOn() {
  name = MARK + location.hash.slice(1);
  location.replace("/s");
}
addEventListener("hashchange", passOn);

async function open(passcode) {
  part("how").hidden = token !== "" || id !== "";
  if (!part("how").hidden) return;
  try {
    await show(await (token ? ask("/api/shared/open", passcode ? { token, passcode } : { token }) : ask(`/api/shared/${id}`)));
  } catch (error) {
    asksPasscode = error.status === 403 || (asksPasscode && error.status === 429);
    part("ask").hidden = !asksPasscode;
    say(error.status === 403 && !passcode ? "" : error.message);
  }
}

part("ask").addEventListener("submit", (event) => {
  event.preventDefault();
  void open(part("passcode").value);
});
part("close").addEventListener("click", async () => {
  const answer = await fetch(opened.links.close, { method: "POST" });
  if (answer.ok || answer.status === 401) location.replace("/s");
  else say("The link could not be closed; try again.");
});
if (location.hash.length > 1) passOn();
else void open("");
