// Files and folders that are dropped onto the page.

/** @typedef {Map<string, File>} Files files by path */

/** Calls `onFiles` with dropped files. @type {(attempt: import('./controls.js').Attempt, onFiles: (files: Files) => Promise<void>) => void} */
export function bind(attempt, onFiles) {
  const hasFiles = (/** @type {DragEvent} */ event) => event.dataTransfer?.types.includes('Files') ?? false;
  addEventListener('dragover', (event) => {
    if (!hasFiles(event)) return;
    event.preventDefault();
    document.body.classList.add('dropping');
  });
  addEventListener('dragleave', (event) => {
    if (!event.relatedTarget) document.body.classList.remove('dropping');
  });
  addEventListener('drop', (event) => {
    document.body.classList.remove('dropping');
    if (!hasFiles(event)) return;
    event.preventDefault();
    // The list of items is empty after this event, so it is read at once.
    const items = Array.from(event.dataTransfer?.items ?? []).filter(({ kind }) => kind === 'file');
    const entries = items.map((item) => item.webkitGetAsEntry()).filter((entry) => entry !== null);
    const plain = Array.from(event.dataTransfer?.files ?? []);
    attempt(async () => onFiles(entries.length > 0 ? await filesOf(entries) : new Map(plain.map((file) => [file.name, file]))));
  });
}

/** Returns the files of entries and their folders. @type {(entries: FileSystemEntry[]) => Promise<Files>} */
async function filesOf(entries) {
  /** @type {Files} */
  const files = new Map();
  const read = async (/** @type {FileSystemEntry} */ entry) => {
    if (entry.isFile) {
      const file = await new Promise((resolve, reject) => /** @type {FileSystemFileEntry} */ (entry).file(resolve, reject));
      files.set(entry.fullPath.replace(/^\//, ''), file);
      return;
    }
    const reader = /** @type {FileSystemDirectoryEntry} */ (entry).createReader();
    for (;;) {
      // A reader returns the entries of a folder in parts.
      /** @type {FileSystemEntry[]} */
      const part = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
      if (part.length === 0) return;
      for (const child of part) await read(child);
    }
  };
  for (const entry of entries) await read(entry);
  return files;
}
