// Questions to the server.

/** The server tells the requests of one tab from those of another by this number. */
const PAGE = String(crypto.getRandomValues(new Uint32Array(1))[0] + 1);

/** A refusal of the server, or no server at all. */
export class Fault extends Error {
  constructor({ kind, message, end }) {
    super(message);
    Object.assign(this, { kind, end });
  }
}

/** Asks, and gives the response of a request that was accepted. */
export async function ask(path, question, signal) {
  const headers = { 'X-Page': PAGE };
  const options = { headers, signal };
  if (question !== undefined) {
    headers['Content-Type'] = 'application/json';
    Object.assign(options, { method: 'POST', body: JSON.stringify(question) });
  }
  let response;
  try {
    response = await fetch(path, options);
  } catch (error) {
    if (error.name === 'AbortError') throw error;
    throw new Fault({ kind: 'gone', message: 'the server does not answer; start cargo xtask explore again' });
  }
  if (!response.ok || response.headers.has('X-Fault')) {
    const told = await response.json().catch(() => null);
    throw new Fault(told?.error ?? { kind: 'broken', message: `the server answers ${response.status}` });
  }
  return response;
}

/** Questions of one kind, one at a time: while one is under way only the newest of those that follow is kept. */
export class Lane {
  constructor(path, take, fail) {
    Object.assign(this, { path, take, fail, next: null, busy: false });
  }

  async ask(question) {
    this.next = question;
    if (this.busy) return;
    this.busy = true;
    try {
      while (this.next) await this.one(this.next);
    } finally {
      this.busy = false;
    }
  }

  async one(asked) {
    this.next = null;
    try {
      this.take(await (await ask(this.path, asked)).json(), asked);
    } catch (fault) {
      if (!(fault instanceof Fault)) throw fault;
      if (fault.kind !== 'overtaken' && !this.next) this.fail(fault, asked);
    }
  }
}
