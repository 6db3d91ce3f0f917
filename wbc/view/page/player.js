// The player of a completed run: play, pause, speed, and a slider over the run's time.
"use strict";
class Player {
  // Times are in s. `show(time)` displays a time; `waiting()` tells that an earlier one is still
  // awaited; `repeats` starts again at the end.
  constructor(start, end, {show, waiting = () => false, repeats = false}) {
    Object.assign(this, {start, end, show, waiting, repeats, playing: true, speed: 1, last: null});
    this.slider = element("seek");
    Object.assign(this.slider, {min: start, max: end, step: "any"});
    this.slider.oninput = () => this.jump(+this.slider.value);
    element("play").onclick = () => this.toggle();
    element("speed").onchange = (event) => { this.speed = +event.target.value; };
    element("player").hidden = end === start;
    const step = (event) => (event.shiftKey ? 1 : 0.02);
    const keys = {
      " ": () => this.toggle(),
      ArrowLeft: (event) => this.jump(this.time - step(event)),
      ArrowRight: (event) => this.jump(this.time + step(event)),
      Home: () => this.jump(start),
      End: () => this.jump(end),
    };
    addEventListener("keydown", (event) => {
      if (!keys[event.key]) return;
      event.preventDefault();
      keys[event.key](event);
    });
    this.go(start);
    requestAnimationFrame((stamp) => this.tick(stamp));
  }

  // Marks falls and resets above the slider; a click on a mark goes to shortly before it.
  mark(markers) {
    const span = this.end - this.start || 1;
    element("marks").replaceChildren(...markers.map(({time, kind, text}) => {
      const mark = document.createElement("button");
      mark.className = `mark ${kind}`;
      mark.title = `${kind} at ${time.toFixed(2)} s${text && `: ${text}`}`;
      mark.style.left = `${100 * (time - this.start) / span}%`;
      mark.onclick = () => this.jump(time - 1);
      return mark;
    }));
  }

  go(time) {
    this.time = Math.min(Math.max(time, this.start), this.end);
    this.slider.value = this.time;
    element("clock").textContent = `${this.time.toFixed(2)} / ${this.end.toFixed(2)} s`;
    this.show(this.time);
  }

  jump(time) {
    this.playing = false;
    this.go(time);
  }

  toggle() {
    if (!this.playing && this.time >= this.end) this.go(this.start);
    this.playing = !this.playing;
  }

  tick(stamp) {
    requestAnimationFrame((next) => this.tick(next));
    element("play").textContent = this.playing ? "❚❚" : "▶";
    if (this.playing && this.waiting()) return;  // the time that passes counts for the next frame
    const passed = this.last === null ? 0 : (stamp - this.last) / 1000;
    this.last = stamp;
    if (!this.playing || this.start === this.end) return;
    if (this.time < this.end) this.go(this.time + this.speed * Math.min(passed, 0.5));
    else if (this.repeats) this.go(this.start);
    else this.playing = false;
  }
}
