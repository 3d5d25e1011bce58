'use strict';
// Values of the heat maps as text and as colours.

/** Formats a value in at most five characters. */
function digits(x) {
  const power = () => x.toExponential(0).replace('e+', 'e');
  if (x > 0 && x < 0.005) return power();
  if (x > 0.995 && x < 1) return '>0.99';
  if (x >= 1e5) return power();
  return String(Number(x.toFixed(x < 1 ? 2 : x < 100 ? 1 : 0)));
}

/** Returns the colour of a share of 0 to 1 between the stops; larger shares are darker. */
function shade(stops, share) {
  const place = Math.max(0, Math.min(1, share)) * (stops.length - 1);
  const below = Math.min(Math.floor(place), stops.length - 2);
  const rgb = stops[below].map((from, i) => Math.round(from + (stops[below + 1][i] - from) * (place - below)));
  const light = 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2];
  // The light end follows the theme.
  const fill = place < 1 ? 'color-mix(in srgb, var(--one), rgb(' + stops[1] + ') ' + 100 * place + '%)' : 'rgb(' + rgb + ')';
  return { fill, ink: light > 140 ? 'var(--one-ink)' : '#ffffff' };
}
