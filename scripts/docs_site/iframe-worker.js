// The search of the site runs in a web worker. Browsers start no worker for a page that was opened as a file, so for such
// a page the search runs in a hidden frame.
if (location.protocol === 'file:') {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const program = new URL(url, location).href;
      this.waiting = [];
      const frame = document.createElement('iframe');
      frame.hidden = true;
      document.documentElement.append(frame);
      const inside = frame.contentWindow, page = frame.contentDocument;
      inside.postMessage = data =>
        this.dispatchEvent(new MessageEvent('message', {data: structuredClone(data)}));
      inside.importScripts = (...sources) => sources.reduce((before, source) => before.then(() => new Promise((done, fail) => {
        const script = page.createElement('script');
        Object.assign(script, {src: new URL(source, program).href, onload: done, onerror: fail});
        page.head.append(script);
      })), Promise.resolve());
      inside.importScripts(program).then(() => {
        this.deliver = data => inside.dispatchEvent(new MessageEvent('message', {data}));
        this.waiting.forEach(this.deliver);
      });
    }

    postMessage(data) {
      if (this.deliver) this.deliver(data);
      else this.waiting.push(data);
    }

    terminate() {}
  };
}
