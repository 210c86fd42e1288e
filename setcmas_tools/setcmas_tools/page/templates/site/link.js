// Links that carry a law and its scenario in the fragment, compressed; and what the page keeps across reloads.

const MOST_LETTERS = 8000, MOST_BYTES = 200_000;  // of a link, and of what it unpacks to
const FILE_NAME = /^[A-Za-z_]\w{0,60}\.py$/;

const packed = async (bytes, stream) => new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());

async function unpacked(bytes) {
  const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate-raw')).getReader(), parts = [];
  for (let size = 0, part; !(part = await reader.read()).done;) {
    size += part.value.length;
    if (size > MOST_BYTES) throw new Error('too large');
    parts.push(part.value);
  }
  return new Blob(parts).text();
}

// Return the address of this page with the work in its fragment; throws an Error that says why it cannot.
export async function linkTo(work) {
  const bytes = await packed(new TextEncoder().encode(JSON.stringify(work)), new CompressionStream('deflate-raw'));
  const code = btoa(Array.from(bytes, one => String.fromCharCode(one)).join('')).replace(/\+/g, '-').replace(/\//g, '_').replace(/=+$/, '');
  const link = `${location.href.split('#')[0]}#code=${code}`;
  if (link.length > MOST_LETTERS) throw new Error(
    `The law is too long for a link: it would have ${link.length} letters, and mail programs and chats keep ${MOST_LETTERS}. Save the script and send the file.`);
  return link;
}

// Return the work that a fragment carries; throws if it carries none that can be read.
export async function workOf(code) {
  const bytes = Uint8Array.from(atob(code.replace(/-/g, '+').replace(/_/g, '/')), letter => letter.charCodeAt(0));
  return checked(JSON.parse(await unpacked(bytes)));
}

// Return a stranger's work with texts only, where texts must be.
export function checked({name, text, source, values, set}) {
  if (typeof text !== 'string' || text.length > MOST_BYTES) throw new Error('no text');
  const isPlain = value => ['string', 'boolean'].includes(typeof value);
  return {
    text, name: FILE_NAME.test(name) ? name : 'my_law.py', source: String(source || ''), set: String(set || '').slice(0, 2000),
    values: Object.fromEntries(Object.entries(values || {}).filter(([, value]) => isPlain(value))),
  };
}

// A key of its own for each folder of pages on a server.
const KEY = `setcmas site ${location.pathname.replace(/[^/]*$/, '')}`;

export function kept() {
  try { return checked(JSON.parse(localStorage.getItem(KEY))); } catch { return null; }
}
export function keep(work) {
  try { localStorage.setItem(KEY, JSON.stringify(work)); return true; } catch { return false; }
}
