// Histograms are small beside the picture: one that is clicked is shown as large as the window, until the next click.

export function enlargePlots() {
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
