// In a frame of an origin of its own: it starts the worker, which has that origin and the policy of the frame, too.
addEventListener('message', ({source, data, ports}) => {
  if (source !== parent) return;
  const worker = new Worker(URL.createObjectURL(new Blob([data], {type: 'text/javascript'})));
  worker.postMessage(null, ports);
}, {once: true});
