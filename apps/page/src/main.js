// The viewer of a page that Camber wrote: everything that it shows is in the page.
import { listen } from "./keys.js";
import { readMesh } from "./mesh.js";
import { enlargePlots } from "./plots.js";
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

enlargePlots();
start().catch(failed);
