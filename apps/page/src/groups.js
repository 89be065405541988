// The list of groups: which elements and which faces of the boundary are drawn.
const $ = (id) => document.getElementById(id);

const headings = { elements: "Elements", faces: "Boundary" };

function checkBox(text, change) {
  const label = document.createElement("label");
  const box = document.createElement("input");
  box.type = "checkbox";
  box.checked = true;
  box.onchange = change;
  label.append(box, " ", text);
  return { label, box };
}

/// Check boxes for the groups of elements and of the boundary. A page without several groups has no list.
export class Groups {
  constructor(page, apply) {
    this.apply = apply;
    this.lists = page.quantities.filter((q) => q.scale === "categories").map((quantity) => this.list(quantity));
    $("groups").hidden = this.lists.length === 0;
    $("groupsAll").onclick = () => this.setAll(true);
    $("groupsNone").onclick = () => this.setAll(false);
  }

  list(quantity) {
    const heading = document.createElement("h3");
    heading.textContent = headings[quantity.on];
    $("groupList").append(heading);
    const boxes = quantity.categories.map((reference, i) => {
      const name = quantity.names?.[i];
      const { label, box } = checkBox(name ? `${name} (${reference})` : String(reference), () => this.changed());
      box.id = `group-${quantity.on}-${reference}`;
      $("groupList").append(label);
      return { reference, box };
    });
    return { quantity, boxes };
  }

  setAll(checked) {
    for (const { boxes } of this.lists) for (const { box } of boxes) box.checked = checked;
    this.changed();
  }

  changed() {
    this.apply(
      this.lists.map(({ quantity, boxes }) => ({
        quantity,
        references: new Set(boxes.filter(({ box }) => !box.checked).map(({ reference }) => reference)),
      })),
    );
  }
}
