// Colours of the drawing in the light and the dark theme. Pairs that carry meaning differ in lightness, too.

const THEMES = {
  light: {
    background: '#f7f8fa', plain: '#b4c4d6', missing: '#bdbdbd', invalid: '#d0006f', line: '#1d2733', inside: '#8a8f98',
    sharp: '#10161e', border: '#d55e00', region: '#10161e', feature: '#10161e', track: '#8f0f7b', field: '#1f5fa8', singular: '#d55e00',
    skeleton: '#b3002d', tube: '#b3002d', fewer: '#d55e00', more: '#0062b1', mark: '#c4007a', vectors: '#1f5fa8',
  },
  dark: {
    background: '#14181f', plain: '#8ea3bb', missing: '#6b6f76', invalid: '#ff5fb0', line: '#05080c', inside: '#4d535c',
    sharp: '#f4f6f9', border: '#ffa24d', region: '#f4f6f9', feature: '#f4f6f9', track: '#ffd9f6', field: '#0a2746', singular: '#ffb15c',
    skeleton: '#ff6b81', tube: '#ff6b81', fewer: '#ff9d42', more: '#55b4ff', mark: '#ff7ad1', vectors: '#0a2746',
  },
};

/** `auto` follows the system. */
export function themeOf(choice) {
  const dark = choice === 'auto' ? matchMedia('(prefers-color-scheme: dark)').matches : choice === 'dark';
  return { name: dark ? 'dark' : 'light', ...THEMES[dark ? 'dark' : 'light'] };
}

/** Red, green, blue in 0 to 1, as stored. */
export const rgb = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255);
