// What keys do. Arrows turn a mesh, or move it with Shift.

const turn = 1 / 24; // of the window

const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

const actions = {
  "+": "nearer",
  "=": "nearer",
  "-": "farther",
  f: "fit",
  h: "wholeView",
  e: "switchLines",
  c: "nextColour",
  t: "switchTheme",
  "?": "switchHelp",
  Escape: "clear",
  X: "alongX",
  Y: "alongY",
  Z: "alongZ",
};

export function listen(panel) {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
    if (act(panel, event)) event.preventDefault();
  });
}

function act(panel, { key, shiftKey }) {
  const { orbit } = panel.view;
  if (moves[key]) {
    const [x, y] = moves[key].map((m) => m * turn);
    if (shiftKey) orbit.pan(x, y);
    else orbit.rotate(x, y);
  } else if (actions[key]) panel[actions[key]]();
  else if ("xyz".includes(key)) {
    if (!document.getElementById(`cut-${key}`).hidden) panel.cutAlong(panel.axis === "xyz".indexOf(key) ? -1 : "xyz".indexOf(key));
  } else if (key === "[" || key === "]") panel.moveCut(key === "]" ? 1 : -1);
  else if (/^[0-9]$/.test(key)) panel.choose((Number(key) + 9) % 10);
  else return false;
  return true;
}
