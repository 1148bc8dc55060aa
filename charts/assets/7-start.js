// Brings every chart of the page to life, joins groups, and follows light, dark and paper.

const charts = [...document.querySelectorAll("figure.chart")].map((figure) => new Chart(figure));
const groups = new Map();
for (const chart of charts) {
  const { group } = chart.spec;
  if (group) groups.set(group, [...(groups.get(group) || []), chart]);
}
for (const members of groups.values()) for (const chart of members) chart.peers = members;
for (const chart of charts) listen(chart);

function repaint() {
  theme.clear();
  for (const swatch of document.querySelectorAll("[data-ramp]")) swatch.style.background = ramp(Number(swatch.dataset.ramp));
  for (const chart of charts) if (chart.pen) chart.paint();
}
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
window.addEventListener("beforeprint", () => {
  document.documentElement.dataset.theme = "light";
  repaint();
});
window.addEventListener("afterprint", () => {
  delete document.documentElement.dataset.theme;
  repaint();
});
requestAnimationFrame(repaint);
