// Python in a worker, inside a frame of an origin of its own; ending it removes the frame.

const TICK_MS = 1000;

const asked = new Map();  // files by address: they are asked for once, also if the worker is ended
function download({address, integrity}) {
  if (!asked.has(address)) asked.set(address, (async () => {
    let answer;
    try {
      answer = await fetch(address, {integrity, credentials: 'omit', referrerPolicy: 'no-referrer'});
    } catch {
      throw new Error(`${address} cannot be loaded: there is no network, or the file is not that of this version; press Run to try again`);
    }
    if (!answer.ok) throw new Error(`${address} cannot be loaded: the server answers ${answer.status} ${answer.statusText}`);
    return answer.arrayBuffer();
  })());
  asked.get(address).catch(() => asked.delete(address));
  return asked.get(address);
}
const contentsOf = entries => Promise.all(entries.map(async one => [one.name, await download(one)]));

export class Python {
  // `parts` is the content of python.json; `hear` gets each message that Python sends during a call.
  constructor(parts, hear) { Object.assign(this, {parts, hear, waiting: new Map(), ids: 0, ready: null, frame: null, started: false}); }

  start() {
    if (this.ready) return this.ready;
    const ready = this.ready = Promise.race([this.boot(), new Promise((_, reject) => { this.abort = reject; })]);
    ready.catch(error => { if (ready === this.ready) this.end(error.message); });
    return ready;
  }

  async boot() {
    const {parts} = this, script = fetch('worker.js').then(answer => answer.text());
    const frame = this.frame = Object.assign(document.createElement('iframe'), {hidden: true, src: 'sandbox.html', title: 'Python'});
    frame.sandbox = 'allow-scripts';
    const loaded = new Promise(resolve => frame.addEventListener('load', resolve, {once: true}));
    document.body.append(frame);
    const [source, contents] = await Promise.all([script, contentsOf(parts.first), loaded]);
    if (frame !== this.frame) throw new Error('stopped');
    const {port1, port2} = new MessageChannel();
    frame.contentWindow.postMessage(source, '*', [port2]);
    this.port = port1;
    port1.onmessage = ({data}) => this.take(data);
    await this.send({does: 'boot', contents, packages: parts.packages});
    this.started = true;
  }

  send(message) {
    const id = ++this.ids;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, {resolve, reject});
      this.port.postMessage({id, ...message});
    });
  }

  take({id, answer, error, say}) {
    this.heard = performance.now();
    if (say !== undefined) { this.hear(JSON.parse(say)); return; }
    const waiting = this.waiting.get(id);
    this.waiting.delete(id);
    if (error) waiting?.reject(new Error(error)); else waiting?.resolve(answer);
  }

  // Call a function of site_worker; `limit` is the longest silence in ms. Packages that it needs are loaded first.
  async call(name, request = {}, limit = Infinity) {
    await this.start();
    this.heard = performance.now();
    const watch = this.watch(limit);
    try {
      const answer = await this.send({does: 'call', name, request: JSON.stringify({...request, limit: limit / 1000})});
      if (typeof answer !== 'string') return answer;
      const found = JSON.parse(answer);
      if (found.broken) throw new Error(found.error);
      if (!found.needs) return found;
    } catch (error) {
      this.end(error.message);  // what the script has left of it may answer nothing any more
      throw error;
    } finally { clearInterval(watch); }
    this.hear({loading: 'plots'});
    await this.send({does: 'load', contents: await contentsOf(this.parts.later), packages: this.parts.later_packages});
    return this.call(name, request, limit);
  }

  watch(limit) {
    let late = 0;  // twice, because this computer may have slept
    return setInterval(() => {
      late = performance.now() - this.heard > limit ? late + 1 : 0;
      if (late > 1) this.end('silent');
    }, TICK_MS);
  }

  // End the worker at once, whatever it does; all calls that wait fail with the reason.
  end(reason) {
    this.frame?.remove();
    this.abort?.(new Error(reason));
    Object.assign(this, {frame: null, ready: null, started: false});
    for (const {reject} of this.waiting.values()) reject(new Error(reason));
    this.waiting.clear();
  }
}
