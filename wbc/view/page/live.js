// The live page: objects and frames arrive through a web socket of the viewer's process.
// The page acknowledges each frame, and the next is sent only then: a slow page skips
// frames instead of falling behind.
"use strict";
let objects = [];

function connect() {
  const socket = new WebSocket(`ws://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  socket.onmessage = (message) => {
    if (message.data instanceof ArrayBuffer) {
      addBody(new Uint8Array(message.data));
      return;
    }
    const news = JSON.parse(message.data);
    if (news.scale) makeStage(news.scale);
    if (news.paths) {
      objects = nodesAt(news.paths);
      finishBodies();
      socket.send("bodies");
    }
    if (news.caption) {
      news.nodes.forEach((node, i) => place(objects[node], news.poses, 10 * i));
      show(news.caption);
      viewer.set_dirty();
      requestAnimationFrame(() => {
        wbc.frames += 1;
        wbc.ready = true;
        socket.send("frame");
      });
    }
  };
  socket.onclose = () => {
    element("status-light").style.background = "#b8c0c8";
    element("phase").textContent = "the run has ended";
  };
}
connect();
