// Draws the API reference from the server's /openapi.json.

import { call, query, setToken } from './api.js';
import { curlButton, curlOf } from './curl.js';
import { byId, el } from './dom.js';

const methods = ['get', 'put', 'post', 'patch', 'delete'];
let contract = {};

const resolved = (node) => (node?.$ref
  ? resolved(node.$ref.slice(2).split('/').reduce((at, key) => at[key], contract)) : node ?? {});
const nameOf = (node) => node?.$ref?.split('/').at(-1);

function link(name) {
  return el('a', { href: `#schema-${name}`, onclick: () => { byId(`schema-${name}`).open = true; } }, name);
}

// The type as DOM nodes: "array of Site", "number or null, at least 0".
function typeOf(schema) {
  if (!schema) return ['any'];
  if (schema.$ref) return [link(nameOf(schema))];
  const parts = schema.oneOf ?? schema.allOf;
  if (parts) {
    const between = schema.oneOf ? ' or ' : ' and ';
    return parts.flatMap((part, i) => [...(i ? [between] : []), ...typeOf(part)]);
  }
  if (schema.type === 'array') return ['array of ', ...typeOf(schema.items)];
  const words = [[schema.type ?? (schema.enum ? 'one of' : 'any')].flat().join(' or ')];
  if (schema.const !== undefined) words.push(`always ${schema.const}`);
  if (schema.enum) words.push(schema.enum.join(', '));
  if (schema.minimum !== undefined) words.push(`at least ${schema.minimum}`);
  if (schema.maximum !== undefined) words.push(`at most ${schema.maximum}`);
  if (schema.default !== undefined) words.push(`default ${JSON.stringify(schema.default)}`);
  return [words.join(', ')];
}

function row(name, type, note) {
  return el('tr', {}, el('th', { scope: 'row' }, name), el('td', {}, type, note ? el('small', {}, ` ${note}`) : null));
}

const table = (rows) => el('table', {}, el('tbody', {}, rows));

function propertyRows(schema) {
  const required = new Set(schema.required ?? []);
  const own = Object.entries(schema.properties ?? {}).map(([name, property]) =>
    row(name, typeOf(property), [required.has(name) ? 'required.' : '', property.description ?? ''].join(' ').trim()));
  const ofParts = [schema.allOf ?? [], schema.type === 'array' ? [schema.items] : []].flat()
    .filter((part) => !part.$ref).flatMap((part) => propertyRows(part));
  return [...own, ...ofParts];
}

// Media types with their schemas. Fields are listed for schemas without a name.
function contentNodes(content) {
  return Object.entries(content ?? {}).flatMap(([type, { schema }]) => {
    const rows = schema && !schema.$ref ? propertyRows(schema) : [];
    return [el('p', {}, el('code', {}, type), schema ? ': ' : '', schema ? typeOf(schema) : ''), rows.length ? table(rows) : null];
  });
}

function commandOf(path, method, parameters) {
  const needed = parameters.filter((p) => p.in === 'query' && p.required).map((p) => [p.name, `<${p.name}>`]);
  const filled = path.replaceAll(/\{(\w+)\}/g, '<$1>') + decodeURIComponent(query(Object.fromEntries(needed)));
  return curlOf(filled, method === 'get' ? '' : `-X ${method.toUpperCase()}`);
}

function callNode(path, method, item) {
  const operation = item[method];
  const parameters = [...(item.parameters ?? []), ...(operation.parameters ?? [])].map(resolved);
  const body = operation.requestBody;
  const command = () => commandOf(path, method, parameters);
  const node = el('details', { class: 'call' },
    el('summary', {}, el('span', { class: 'method' }, method.toUpperCase()), el('code', {}, path), el('span', {}, operation.summary ?? '')),
    operation.description ? el('p', {}, operation.description) : null,
    parameters.length ? [el('h4', {}, 'Parameters'), table(parameters.map((p) =>
      row(`${p.name} (${p.in})`, typeOf(p.schema), [p.required ? 'required.' : '', p.description ?? ''].join(' ').trim())))] : null,
    body ? [el('h4', {}, body.required ? 'Body' : 'Body (optional)'), ...contentNodes(body.content)] : null,
    el('h4', {}, 'Responses'),
    el('p', {}, 'Errors are ', el('code', {}, 'application/problem+json'), ': ', link('Problem')),
    table(Object.entries(operation.responses).map(([status, response]) => {
      const { description, content } = resolved(response);
      // Shared responses are errors, all with the schema Problem.
      return row(status, response.$ref ? [] : contentNodes(content), description);
    })),
    el('pre', {}, command()), curlButton(`${method} ${path}`, command));
  node.dataset.text = `${path} ${JSON.stringify(operation)}`.toLowerCase();
  return node;
}

function schemaNode(name, schema) {
  const rows = propertyRows(schema);
  const node = el('details', { id: `schema-${name}` },
    el('summary', {}, el('code', {}, name), el('small', {}, schema.description ?? '')),
    rows.length ? table(rows) : el('p', {}, typeOf(schema)));
  node.dataset.text = `${name} ${JSON.stringify(schema)}`.toLowerCase();
  return node;
}

function find() {
  const wanted = byId('find').value.trim().toLowerCase();
  for (const node of document.querySelectorAll('.docs details')) node.hidden = !node.dataset.text.includes(wanted);
}

async function draw() {
  try {
    contract = await (await call('/openapi.json')).json();
  } catch (error) {
    byId('fault').hidden = false;
    byId('fault').textContent = error.message;
    byId('token-form').hidden = error.status !== 401;
    return;
  }
  byId('fault').hidden = true;
  byId('token-form').hidden = true;
  byId('about').textContent = contract.info.description;
  byId('calls').replaceChildren(...Object.entries(contract.paths).flatMap(([path, item]) =>
    methods.filter((method) => item[method]).map((method) => callNode(path, method, item))));
  byId('schemas').replaceChildren(...Object.entries(contract.components.schemas).map(([name, schema]) => schemaNode(name, schema)));
  const asked = location.hash.startsWith('#schema-') ? byId(location.hash.slice(1)) : null;
  if (asked) asked.open = true;
}

byId('find').addEventListener('input', find);
byId('token-form').addEventListener('submit', (event) => {
  event.preventDefault();
  setToken(byId('token-value').value, false);
  draw();
});
draw();
