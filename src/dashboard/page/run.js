// An interactive simulation in the service: starts it, receives its frames, and sends control commands.

import { ApiError, events, post, remove } from './transport.js';

/**
 * @typedef {import('./history.js').History} History
 * @typedef {import('./types.js').Simulation} Simulation
 * @typedef {import('./types.js').SimulationControl} SimulationControl
 * @typedef {import('./types.js').SimulationRequest} SimulationRequest
 * @typedef {import('./types.js').LiveFrame} LiveFrame
 * @typedef {import('./types.js').LiveSample} LiveSample
 */

/** Number of tries to start a run while the service is busy, and the time between them, ms. Within 5 s the service takes the place of a run whose page went without a word. */
const TRIES = 30;
const BETWEEN = 200;

/** Returns the sample of the posture of a frame: that of the last finished period. A frame can have later samples, or only those. @type {(frame: LiveFrame) => LiveSample | undefined} */
function sampleOfArm({ time_s: end, done, samples }) {
  // Times are rounded, so they are compared with the middle of the period.
  const middle = end - end / done / 2;
  return samples.findLast(({ time_s }) => time_s < middle);
}

/** One run; `follow` receives its frames until it ends or is deleted. */
export class Run {
  /**
   * @param {Simulation} simulation
   * @param {(run: Run) => void} onFrame
   * @param {(run: Run, reason: 'end' | 'lost', error?: unknown) => void} onEnd
   * @param {History} history receives the samples
   */
  constructor(simulation, onFrame, onEnd, history) {
    this.id = simulation.id;
    this.path = `/v1/simulations/${simulation.id}`;
    this.simulation = simulation;
    this.history = history;
    /** @type {LiveFrame | null} */
    this.frame = null;
    this.ended = false;
    this.abort = new AbortController();
    this.follow(onFrame, onEnd);
  }

  /**
   * @param {SimulationRequest} request
   * @param {(run: Run) => void} onFrame
   * @param {(run: Run, reason: 'end' | 'lost', error?: unknown) => void} onEnd
   * @param {History} history
   */
  static async start(request, onFrame, onEnd, history) {
    for (let tries = 1; ; tries += 1) {
      try {
        return new Run(await post('/v1/simulations', request), onFrame, onEnd, history);
      } catch (error) {
        // Runs that were just deleted need a moment to end, and the service limits their number.
        if (!(error instanceof ApiError) || error.status !== 503 || tries === TRIES) throw error;
        await new Promise((resolve) => { setTimeout(resolve, BETWEEN); });
      }
    }
  }

  /**
   * @param {(run: Run) => void} onFrame
   * @param {(run: Run, reason: 'end' | 'lost', error?: unknown) => void} onEnd
   */
  async follow(onFrame, onEnd) {
    const onEvent = (/** @type {string} */ name, /** @type {LiveFrame} */ frame) => {
      this.frame = frame;
      this.simulation = frame.run;
      for (const sample of frame.samples) this.history.push(sample);
      const shown = sampleOfArm(frame);
      if (shown) this.history.pushArm(shown.time_s, frame.arm);
      this.ended = name === 'end';
      onFrame(this);
    };
    try {
      await events(`${this.path}/live`, onEvent, this.abort.signal);
      if (!this.abort.signal.aborted) onEnd(this, this.ended ? 'end' : 'lost');
    } catch (error) {
      if (!this.abort.signal.aborted) onEnd(this, 'lost', error);
    }
  }

  /** @param {SimulationControl} command */
  async control(command) {
    if (this.ended) return;
    const simulation = await post(`${this.path}/control`, command);
    // The last frame can arrive before this answer; it is newer.
    if (!this.ended) this.simulation = simulation;
  }

  /** Stops following the run and deletes it in the service. */
  async delete() {
    this.abort.abort();
    await remove(this.path).catch(() => {});
  }
}
