// Records the scene as a WebM film.

/** Largest number of pictures per second, bits per second, and the largest duration, ms. */
const RATE = 30;
const BITS = 8_000_000;
const LONGEST = 120_000;

/** Kinds of film, best first. */
const KINDS = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm'];

export class Recorder {
  /** @param {import('./scene.js').Scene} scene @param {(film: Blob) => void} onFilm @param {() => void} onChange */
  constructor(scene, onFilm, onChange) {
    this.scene = scene;
    this.onFilm = onFilm;
    this.onChange = onChange;
    /** @type {MediaRecorder | null} */
    this.recorder = null;
    this.canvas = document.createElement('canvas');
  }

  get isRecording() {
    return this.recorder !== null;
  }

  /** Starts or ends a film. */
  toggle() {
    if (this.recorder) {
      this.recorder.stop();
      return;
    }
    if (typeof MediaRecorder === 'undefined') throw new Error('this browser records no films; use the recorder of the screen');
    this.scene.paint(this.canvas);
    const mimeType = KINDS.find((kind) => MediaRecorder.isTypeSupported(kind));
    if (!mimeType) throw new Error('this browser records no WebM films; use the recorder of the screen');
    const recorder = new MediaRecorder(this.canvas.captureStream(RATE), { mimeType, videoBitsPerSecond: BITS });
    /** @type {Blob[]} */
    const parts = [];
    recorder.ondataavailable = ({ data }) => parts.push(data);
    recorder.onstop = () => {
      this.recorder = null;
      this.onFilm(new Blob(parts, { type: 'video/webm' }));
      this.onChange();
    };
    recorder.start(1000);
    setTimeout(() => recorder.state === 'recording' && recorder.stop(), LONGEST);
    this.recorder = recorder;
    this.onChange();
  }

  /** Adds the picture that was just drawn. */
  addPicture() {
    if (this.recorder) this.scene.paint(this.canvas);
  }
}
