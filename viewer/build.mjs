// Bundles the viewer into the two files that the library includes; with --check compares them instead.
import { build } from 'esbuild';
import { readFile, writeFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const target = join(here, '../crates/carreau/src/report/page');

const result = await build({
  absWorkingDir: here,
  entryPoints: { viewer: 'src/main.js' },
  outdir: target,
  write: false,
  bundle: true,
  minify: true,
  format: 'iife',
  target: ['es2022'],
  charset: 'ascii',
  legalComments: 'inline',
  logLevel: 'warning',
});

let stale = 0;
for (const file of result.outputFiles) {
  // What stands in a script element must not end it, nor open a comment that would.
  if (/<\/(script|style)|<!--|<script/i.test(file.text)) throw new Error(`${file.path} cannot stand in HTML`);
  if (!process.argv.includes('--check')) {
    await writeFile(file.path, file.contents);
    console.log(`${file.path}: ${file.contents.length} bytes`);
  } else if (!(await readFile(file.path)).equals(file.contents)) {
    console.error(`${file.path} does not match viewer/src: run \`npm ci && npm run build\` in viewer/`);
    stale += 1;
  }
}
process.exitCode = stale;
