// The binary part of a page; crates/carreau/src/report/page/container.rs is the writer.

/** The page's head, and a function from slots to typed arrays. */
export async function readPage() {
  const head = JSON.parse(take('carreau-head'));
  const bytes = await inflate(fromBase64(take('carreau-data')));
  if (bytes.length !== head.bytes) throw new Error(`the page is damaged: ${bytes.length} of ${head.bytes} bytes`);
  return { head, read: (slot) => array(bytes, slot) };
}

/** The text of an element, which is dropped: it may be large. */
function take(id) {
  const element = document.getElementById(id);
  const text = element.textContent;
  element.textContent = '';
  return text;
}

function fromBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let k = 0; k < bytes.length; k++) bytes[k] = binary.charCodeAt(k);
  return bytes;
}

async function inflate(packed) {
  if (typeof DecompressionStream === 'undefined') {
    throw new Error('this browser is too old: it lacks DecompressionStream (Chrome 80, Firefox 113, Safari 16.4 have it)');
  }
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Puts byte planes together and sums differences. */
function array(bytes, { at, count, kind, stride }) {
  if (kind === 'u8') return bytes.slice(at, at + count);
  const out = new Uint32Array(count);
  const [b, c, d] = [at + count, at + 2 * count, at + 3 * count];
  for (let k = 0; k < count; k++) {
    const packed = bytes[at + k] | (bytes[b + k] << 8) | (bytes[c + k] << 16) | (bytes[d + k] << 24);
    const difference = (packed >>> 1) ^ -(packed & 1);
    out[k] = k < stride ? difference : out[k - stride] + difference;
  }
  if (kind === 'f32') return new Float32Array(out.buffer);
  return kind === 'i32' ? new Int32Array(out.buffer) : out;
}
