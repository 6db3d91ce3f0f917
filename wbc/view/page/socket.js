// The connection to the server of a page, which sends the objects of the scene and then frames.
"use strict";
// `onScene` receives the message that follows the objects; `onFrame` is called when a frame is drawn.
function connect(onScene, onFrame, endText) {
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
  socket.onclose = () => {
    element("status-light").style.background = "#b8c0c8";
    element("phase").textContent = endText;
  };
  return socket;
}
