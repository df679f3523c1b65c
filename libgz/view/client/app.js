// @ts-check
// App: makes the page of its parts.

import { Connection } from 'libgz/connection.js';
import { Port } from 'libgz/port.js';
import { Recording } from 'libgz/recording.js';
import { Stage } from 'libgz/stage.js';
import { Store } from 'libgz/store.js';
import { Workplace } from 'libgz/workplace.js';

const store = new Store();
const quality = new URLSearchParams(location.search).get('quality');
const workplace = new Workplace(document.body, store, (parent) => new Stage(parent, store, { quality }));
const recorded = document.getElementById('recording');
const framed = document.getElementById('port') ? new Port(store) : null; // in a notebook
const connection = recorded
  ? new Recording(store, recorded.textContent ?? '', () => workplace.stage.ready)
  : new Connection(store, framed && (() => framed));
store.connect(connection);
void connection.open();

// For tests, and for users' consoles.
Object.assign(window, { libgz: { store, workplace, connection } });
