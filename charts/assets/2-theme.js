// Colours come from the style sheet, so that light, dark and print are decided in one place.

const theme = new Map();

function colour(name) {
  if (!theme.has(name)) {
    const styles = getComputedStyle(document.documentElement);
    theme.set(name, styles.getPropertyValue(`--${name}`).trim() || "#888");
  }
  return theme.get(name);
}

// A ramp that gets steadily darker (or lighter, on dark paper), for heat strips.
const RAMP_LIGHT = [[247, 244, 226], [250, 200, 110], [226, 110, 60], [158, 30, 70], [60, 10, 60]];
const RAMP_DARK = [[38, 36, 52], [96, 40, 92], [178, 60, 84], [238, 130, 76], [252, 224, 150]];

function ramp(part) {
  const stops = colour("scheme") === "dark" ? RAMP_DARK : RAMP_LIGHT;
  const place = Math.max(0, Math.min(1, part)) * (stops.length - 1);
  const index = Math.min(stops.length - 2, Math.floor(place));
  const rest = place - index;
  const mixed = stops[index].map((from, k) => Math.round(from + (stops[index + 1][k] - from) * rest));
  return `rgb(${mixed.join(",")})`;
}
