// Opens a share link: posts the secret behind # once, then shows what the link shows.
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

async function open(passcode) {
  const token = location.hash.slice(1);
  try {
    await show(await (token ? ask("/api/shared/open", passcode ? { token, passcode } : { token }) : ask("/api/shared")));
  } catch (error) {
    part("ask").hidden = error.status !== 403;
    say(error.status === 403 && !passcode ? "" : error.message);
  }
}

part("ask").addEventListener("submit", (event) => {
  event.preventDefault();
  void open(part("passcode").value);
});
void open("");
