// The distribution of a layer of numbers, and its extreme elements.

const BINS = 40;

/** Counts in equal intervals over the range that colours span, widened where values lie beyond. */
export function binsOf(layer) {
  const { stats, values } = layer;
  const low = layer.range === 'quality' ? Math.min(0, Math.max(-1, stats.min)) : stats.low;
  const high = layer.range === 'quality' ? 1 : stats.high;
  const counts = new Uint32Array(BINS);
  for (const v of values) {
    if (!Number.isFinite(v)) continue;
    counts[Math.max(0, Math.min(BINS - 1, Math.floor(((v - low) / (high - low)) * BINS)))]++;
  }
  return { low, high, counts };
}

/** Ids of the elements with the lowest (or highest) values. */
export function extremes(layer, count, highest) {
  const better = highest ? (a, b) => a > b : (a, b) => a < b;
  const found = [];
  layer.values.forEach((v, id) => {
    if (!Number.isFinite(v)) return;
    if (found.length === count && !better(v, found[count - 1].v)) return;
    let at = found.length;
    while (at > 0 && better(v, found[at - 1].v)) at--;
    found.splice(at, 0, { v, id });
    found.length = Math.min(found.length, count);
  });
  return found.map((f) => f.id);
}

/** Draws bars in the colours of the layer; returns the bin at a place of the canvas. */
export function drawHistogram(canvas, layer, ramp, bins, range, ink) {
  const scale = window.devicePixelRatio || 1;
  const [w, h] = [canvas.clientWidth || 260, canvas.clientHeight || 90];
  canvas.width = w * scale;
  canvas.height = h * scale;
  const g = canvas.getContext('2d');
  g.scale(scale, scale);
  const most = Math.max(1, ...bins.counts);
  const width = w / BINS;
  bins.counts.forEach((count, k) => {
    const middle = bins.low + ((k + 0.5) / BINS) * (bins.high - bins.low);
    const place = Math.max(0, Math.min(1, (middle - layer.stats.low) / (layer.stats.high - layer.stats.low)));
    const at = 3 * Math.round(place * 255);
    const kept = !range || (middle >= range[0] && middle <= range[1]);
    g.globalAlpha = kept ? 1 : 0.25;
    g.fillStyle = layer.range === 'quality' && middle < 0 ? ink.invalid : `rgb(${ramp[at]},${ramp[at + 1]},${ramp[at + 2]})`;
    const height = count === 0 ? 0 : Math.max(2, (count / most) * (h - 4));
    g.fillRect(k * width + 0.5, h - height, width - 1, height);
    g.globalAlpha = 1;
  });
  g.strokeStyle = ink.rule;
  g.beginPath();
  g.moveTo(0, h - 0.5);
  g.lineTo(w, h - 0.5);
  g.stroke();
}
