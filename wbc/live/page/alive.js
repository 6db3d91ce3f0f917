// A worker that tells the server ten times a second that the page is there. Unlike the page's own
// timers, those of a worker are slowed down neither by a slow scene nor in a hidden tab.
"use strict";
const PERIOD = 100;  // ms
const SILENCE = 3000;  // ms after which a page that no longer answers counts as gone
let socket = null, seen = 0;

// The page sends its number once, and then whatever shows that it still runs.
onmessage = ({data}) => {
  seen = performance.now();
  socket ??= new WebSocket(`ws://${location.host}/alive?page=${data}`);
};

setInterval(() => {
  if (socket?.readyState === WebSocket.OPEN && performance.now() - seen < SILENCE) socket.send("alive");
}, PERIOD);
