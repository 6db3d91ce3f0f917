// Reads a log with the MCAP and ROS 2 readers of npm, and tells what it found as JSON.
// Usage: node read_log.mjs LOG TOPIC FIELD
import { open } from "node:fs/promises";
import { createRequire } from "node:module";
import { fileURLToPath } from "node:url";

// Packages are looked up from where they are installed, which need not be beside this file.
const folder = process.env.WBC_NODE_MODULES ?? fileURLToPath(new URL(".", import.meta.url));
const require = createRequire(`${folder}/`);
const { McapIndexedReader } = require("@mcap/core");
const { FileHandleReadable } = require("@mcap/nodejs");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const { decompress } = require("fzstd");

const [path, topic, field] = process.argv.slice(2);
const file = await open(path, "r");
const reader = await McapIndexedReader.Initialize({
  readable: new FileHandleReadable(file),
  decompressHandlers: { zstd: (data) => decompress(data) },
});
const decoders = new Map();
const counts = {};
const values = [];
let last = null;
for await (const message of reader.readMessages({ validateCrcs: true })) {
  const channel = reader.channelsById.get(message.channelId);
  if (!decoders.has(channel.schemaId)) {
    const schema = reader.schemasById.get(channel.schemaId);
    const definitions = parse(new TextDecoder().decode(schema.data), { ros2: true });
    decoders.set(channel.schemaId, new MessageReader(definitions));
  }
  const decoded = decoders.get(channel.schemaId).readMessage(message.data);
  counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
  if (channel.topic === topic) values.push(Array.from(decoded[field]));
  last = Number(message.logTime);
}
const metadata = {};
for await (const record of reader.readMetadata()) metadata[record.name] = Object.fromEntries(record.metadata);
console.log(JSON.stringify({ profile: reader.header.profile, counts, values, last, metadata }));
await file.close();
