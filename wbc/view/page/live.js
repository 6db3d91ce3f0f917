// The live page. It acknowledges each frame, and the next is sent only then: a slow page skips
// frames and does not lag.
"use strict";
const acknowledge = () => {
  if (liveSocket.readyState === WebSocket.OPEN) liveSocket.send("ready for a frame");
};
const liveSocket = connect(acknowledge, acknowledge);
