// Tells the service the state of the link, and takes the commands that the answer brings.
// A command is handed over once, however often the service repeats it.

const period_ms = 1000;
const firstPause_ms = 500;
const longestPause_ms = 5000;
// So long the service is told what became of a command.
const commandsKept_ms = 600_000;
const pauseOf = (numFailures) => Math.min(longestPause_ms, firstPause_ms * 2 ** numFailures);

export class Reporter {
  #service;
  #name;
  #state;
  #onCommand;
  #commands = new Map();
  #notBefore_ms = 0;
  #isChanged = false;
  #running;
  #numFailures = 0;
  isReachable = false;
  lastError;

  // state(): the body without `commands`; its `id` names the link unless `name` is given.
  // onCommand({ id, kind, site_id?, issued_at, confirmed_by? }): must not throw; it or what it
  // starts calls told(id, 'done' | 'failed', detail).
  constructor({ service, name, state, onCommand = () => {} }) {
    this.#service = service;
    this.#name = name;
    this.#state = state;
    this.#onCommand = onCommand;
  }

  // The state has changed: the service hears it at the next step.
  changed() { this.#isChanged = true; }

  // state: 'taken' | 'done' | 'failed'.
  told(commandId, state, detail, now_ms = Date.now()) {
    this.#commands.set(commandId, { id: commandId, state, detail, at_ms: now_ms });
    this.changed();
  }

  // Often; it does nothing while a request runs or nothing is due.
  step(now_ms = Date.now()) {
    if (this.#running) return this.#running;
    const isDue = now_ms >= this.#notBefore_ms || (this.#isChanged && this.#numFailures === 0);
    if (!isDue) return Promise.resolve();
    this.#running = this.#report(now_ms).finally(() => { this.#running = undefined; });
    return this.#running;
  }

  async #report(now_ms) {
    const state = this.#state();
    const linkId = this.#name ?? state.id;
    // Nothing is heard yet, so there is no link.
    if (linkId === undefined) return;
    this.#isChanged = false;
    this.#notBefore_ms = now_ms + period_ms;
    try {
      const { commands = [] } = await this.#service.putLink(linkId, { ...state, commands: this.#told(now_ms) });
      this.isReachable = true;
      this.lastError = undefined;
      this.#numFailures = 0;
      for (const command of commands) this.#take(command);
    } catch (error) {
      this.isReachable = error.status !== undefined;
      this.lastError = error.cause?.message ?? error.message;
      this.#notBefore_ms = Date.now() + pauseOf(this.#numFailures);
      ++this.#numFailures;
    }
  }

  #told(now_ms) {
    for (const [id, { at_ms }] of this.#commands) {
      if (now_ms - at_ms > commandsKept_ms) this.#commands.delete(id);
    }
    return [...this.#commands.values()].map(({ id, state, detail }) => ({ id, state, detail }));
  }

  #take(command) {
    if (this.#commands.has(command.id)) return;
    this.told(command.id, 'taken');
    this.#onCommand(command);
  }
}
