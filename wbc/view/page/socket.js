// The connection to the server of a page, which sends the objects of the scene and then frames.
"use strict";
const ENDED = 1000;  // code by which the server closes a connection at the end of a run
const RETRY = 1000;  // ms between two attempts to reach the server again

// Says that the connection is lost, or that the run has ended, and loads the page again as soon as
// there is a server.
function disconnected({code}) {
  const known = wbc.lost;
  if (known === "ended") return;
  wbc.lost = code === ENDED ? "ended" : "lost";
  element("lost").textContent = code !== ENDED ? "Connection lost; trying to reconnect …"
    : wbc.starting ? `Starting ${wbc.starting} …` : "The run has ended";
  element("lost").classList.toggle("starting", code === ENDED && Boolean(wbc.starting));
  element("status-light").style.background = "#b8c0c8";
  if (known) return;
  const attempts = setInterval(async () => {
    const answer = await fetch(location.href, {cache: "no-store"}).catch(() => null);
    if (answer?.ok) location.reload();
    if (answer?.status !== 403) return;
    clearInterval(attempts);
    element("lost").textContent = "Another run is served here: open the address that it printed";
  }, RETRY);
}

// `onScene` receives the message that follows the objects; `onFrame` is called when a frame is drawn.
function connect(onScene, onFrame) {
  const socket = new WebSocket(`ws://${location.host}/socket`);
  let nodes = [];
  socket.binaryType = "arraybuffer";
  socket.onmessage = (event) => {
    if (event.data instanceof ArrayBuffer) {
      viewer.handle_command_bytearray(new Uint8Array(event.data));
      return;
    }
    const message = JSON.parse(event.data);
    if (message.scale) makeSurroundings(message.scale);
    if (message.paths) {
      nodes = nodesAt(message.paths);
      finishScene();
      onScene(message);
    }
    if (message.caption) {
      message.nodes.forEach((node, i) => setPose(nodes[node], message.poses, 10 * i));
      showCaption(message.caption);
      viewer.set_dirty();
      requestAnimationFrame(() => {
        wbc.frames += 1;
        wbc.ready = true;
        onFrame();
      });
    }
  };
  socket.onclose = disconnected;
  return socket;
}
