// The viewer of a page that Camber wrote: everything that it shows is in the page.
import { readMesh } from "./mesh.js";
import { Panel } from "./panel.js";
import { View } from "./view.js";

const root = document.documentElement;

function failed(error) {
  root.dataset.state = "failed";
  document.getElementById("loading").hidden = true;
  const box = document.getElementById("trouble");
  box.hidden = false;
  box.textContent = /WebGL/i.test(error?.message ?? "")
    ? "This browser cannot draw the mesh: WebGL 2 is off. The numbers are below."
    : `The mesh cannot be drawn: ${error?.message ?? error}. The numbers are below.`;
  console.error(error);
}

async function start() {
  const page = JSON.parse(document.getElementById("camber-page").textContent);
  const mesh = await readMesh(page);
  const view = new View(document.getElementById("canvas"), page, mesh);
  const panel = new Panel(page, view);
  await panel.start();
  listen(panel);
  document.getElementById("loading").hidden = true;
  requestAnimationFrame(() =>
    requestAnimationFrame(() => {
      root.dataset.state = "drawn";
      root.dataset.firstFrame = String(Math.round(performance.now()));
    }),
  );
}

// ---------------------------------------------------------------- keys

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

/// Arrows turn a mesh, or move it with Shift.
function listen(panel) {
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

// ---------------------------------------------------------------- histograms

/// Histograms are small beside the picture: one that is clicked is shown as large as the window, until the next click.
function enlargePlots() {
  const dialog = document.getElementById("large");
  dialog.onclick = () => dialog.close();
  for (const plot of document.querySelectorAll(".plots svg")) {
    plot.tabIndex = 0;
    plot.setAttribute("role", "button");
    plot.onclick = () => {
      dialog.replaceChildren(plot.cloneNode(true));
      dialog.showModal();
    };
    plot.onkeydown = ({ key }) => key === "Enter" && plot.onclick();
  }
}

enlargePlots();
start().catch(failed);
