// Runs before the first paint. Applies the user's theme, else the system's.
(() => {
  const key = 'freelsd.theme';
  const dark = matchMedia('(prefers-color-scheme: dark)');
  const apply = () => {
    const chosen = localStorage.getItem(key);
    document.documentElement.dataset.theme = chosen ?? (dark.matches ? 'dark' : 'light');
    dispatchEvent(new Event('freelsd-theme'));
  };
  dark.addEventListener('change', apply);
  addEventListener('DOMContentLoaded', () => {
    document.getElementById('theme').addEventListener('click', () => {
      const other = document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark';
      if (other === (dark.matches ? 'dark' : 'light')) localStorage.removeItem(key);
      else localStorage.setItem(key, other);
      apply();
    });
  });
  apply();
})();
