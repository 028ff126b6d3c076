// Loads the page. A service that is busy or restarts may refuse one of its many files; the page then loads again.

/** Number of times that the page loads again by itself, and the time before each, ms. */
const RETRIES = 10;
const PAUSE = 1000;

/** Key of the number of retries so far, in this browser tab. */
const COUNT = 'revprio-retries';

/** Rejects if a file of the page has not been loaded. */
async function load() {
  await import('./main.js');
  const sheets = [...document.querySelectorAll('link')].filter(({ rel }) => rel === 'stylesheet');
  if (sheets.some(({ sheet }) => !sheet)) throw new Error('the style sheet was not loaded');
}

load().then(() => sessionStorage.removeItem(COUNT), (error) => {
  const retries = Number(sessionStorage.getItem(COUNT));
  sessionStorage.setItem(COUNT, String(retries + 1));
  if (retries < RETRIES) {
    setTimeout(() => location.reload(), PAUSE);
    return;
  }
  sessionStorage.removeItem(COUNT);
  const pill = /** @type {HTMLElement} */ (document.getElementById('connection'));
  pill.dataset.connection = 'unreachable';
  pill.textContent = 'The page was not loaded; reload it';
  throw error;
});
