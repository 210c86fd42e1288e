// The worker: Python and the law run here. It has no network, no storage of the site and no page.

const BASE = 'https://files.invalid/';  // names of files; no address that is asked
const files = new Map();
let python = null, core = null;

self.fetch = async address => {
  const name = String(address.url || address).slice(BASE.length), content = files.get(name);
  if (!content) throw new TypeError('this worker has no network');
  const type = name.endsWith('.wasm') ? 'application/wasm' : 'application/octet-stream';
  return new Response(content, {headers: {'Content-Type': type}});
};
const scriptOf = name => URL.createObjectURL(new Blob([files.get(name)], {type: 'text/javascript'}));

async function boot({contents, packages}) {
  addFiles(contents);
  importScripts(scriptOf('pyodide.asm.js'));
  const {loadPyodide} = await import(scriptOf('pyodide.mjs'));
  python = await loadPyodide({indexURL: BASE, packages});
  for (const [name, format] of [['setcmas.zip', 'wheel'], ['rubrics.zip', 'zip']]) {  // a wheel goes to site-packages
    python.unpackArchive(files.get(name), format);
    files.delete(name);
  }
  core = python.pyimport('setcmas_tools.page.site_worker');
}

function addFiles(contents) {
  for (const [name, content] of contents) files.set(name, content);
}

async function load({contents, packages}) {
  addFiles(contents);
  await python.loadPackage(packages);
}

function call(name, request, say) {
  const answer = name === 'run_zip' ? core.run_zip() : core.answer(name, request, text => say(text));
  if (typeof answer === 'string') return answer;
  const bytes = answer.toJs();
  answer.destroy();
  return bytes;
}

self.addEventListener('message', ({ports: [port]}) => {
  port.onmessage = async ({data: {id, does, name, request, ...more}}) => {
    try {
      if (does === 'boot') await boot(more);
      else if (does === 'load') await load(more);
      const answer = does === 'call' ? call(name, request, text => port.postMessage({say: text})) : true;
      port.postMessage({id, answer});
    } catch (error) {
      port.postMessage({id, error: String(error)});
    }
  };
}, {once: true});
