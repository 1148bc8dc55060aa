// What Bokeh has no property for: colours of light, dark and paper from the style sheet, curves
// hidden by buttons that a keyboard reaches, saving as a picture or as numbers, a finger that
// scrolls the page.
const drawn = JSON.parse(document.getElementById("drawn").textContent);
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

function paint(views) {
  for (const view of views) {
    for (const renderer of view.model.renderers) {
      if (!renderer.tags.length) continue;
      const { glyph } = renderer;
      for (const name of ["line_color", "fill_color"]) if (name in glyph.properties) glyph[name] = { value: css(renderer.tags[0]) };
    }
    view.invalidate_layout();
  }
}

// On paper charts are light and as wide as a sheet. The browser looks as soon as this returns, so
// each is drawn again at once, not at the next frame. The canvas above it is left out: where it is
// clear, Chromium's PDF would be blank.
function onto(views, paper) {
  document.documentElement.toggleAttribute("data-paper", paper);
  for (const { canvas_view: canvas } of views) {
    canvas.overlays.el.style.display = paper ? "none" : "";
    canvas.update_bbox();
  }
  paint(views);
  for (const view of views) {
    view.request_paint();
    view.paint();
  }
}

function table(view) {
  const lines = [];
  const seen = new Set();
  const cell = (value) => (typeof value === "string" ? `"${value.replaceAll('"', '""')}"` : value);
  for (const { data_source: source } of view.model.renderers) {
    if (seen.has(source)) continue;
    seen.add(source);
    const names = Object.keys(source.data);
    const titles = JSON.parse(view.figure.dataset.columns);
    lines.push(names.map((name) => cell(titles[name] || name)).join(","));
    for (let i = 0; i < source.get_length(); i++) lines.push(names.map((name) => cell(source.data[name][i])).join(","));
    lines.push("");
  }
  return new Blob([lines.join("\r\n")], { type: "text/csv" });
}

function save(blob, title, kind) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = `${title.replace(/[^\p{L}\p{N}]+/gu, "-")}.${kind}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

const figures = new Map([...document.querySelectorAll(".plot")].map((place) => [place.id, place.closest("figure")]));

Bokeh.embed.embed_items(drawn.docs, drawn.items).then(([found]) => {
  const views = found.roots.filter((view) => figures.has(view.model.name));
  for (const view of views) {
    view.figure = figures.get(view.model.name);
    if (matchMedia("(pointer: coarse)").matches) view.model.toolbar.active_drag = null;
    view.figure.addEventListener("click", async ({ target }) => {
      const button = target.closest("button");
      if (!button) return;
      const { save: kind, series } = button.dataset;
      if (kind) save(kind === "csv" ? table(view) : await view.export(kind).to_blob(), view.figure.dataset.title, kind);
      if (!series) return;
      const shown = button.getAttribute("aria-pressed") !== "true";
      button.setAttribute("aria-pressed", String(shown));
      for (const renderer of view.model.renderers) if (renderer.name === series) renderer.visible = shown;
    });
  }
  const again = () => paint(views);
  again();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
  addEventListener("beforeprint", () => onto(views, true));
  addEventListener("afterprint", () => onto(views, false));
  document.documentElement.dataset.drawn = "true";
});
