// Checks an AsyncAPI document: node asyncapi.cjs FILE
const { Parser } = require("@asyncapi/parser");
const text = require("fs").readFileSync(process.argv[2], "utf8");
new Parser().parse(text).then(({ document, diagnostics }) => {
  const errors = diagnostics.filter((d) => d.severity === 0);
  errors.forEach((d) => console.error(d.path.join("/"), d.message));
  process.exit(document && !errors.length ? 0 : 1);
});
