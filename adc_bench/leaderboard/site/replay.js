"use strict";
// Shows one run at a time, and moves the robots and the cursors to the time of its slider.

document.documentElement.classList.add("scripted");
const choice = document.querySelector("select[name=run]");
const players = new Map([...document.querySelectorAll(".run")].map((run) => [run.id, playerOf(run)]));

function playerOf(run) {
  const data = JSON.parse(run.querySelector("script").textContent);
  const slider = run.querySelector("input[type=range]");
  const button = run.querySelector(".play");
  const player = {run, data, slider, button, speed: run.querySelector("select"), frame: 0};
  slider.addEventListener("input", () => show(player, Number(slider.value)));
  button.addEventListener("click", () => (player.frame ? stop(player) : play(player)));
  for (const event of run.querySelectorAll("[data-at]")) {
    event.addEventListener("click", () => show(player, Number(event.dataset.at)));
  }
  show(player, 0);
  return player;
}

// The value of a column at a time, in metres or radians, between its samples; the last sample is at the end.
function at(data, name, time, perUnit) {
  const column = data[name], last = column.length - 1;
  const k = Math.max(0, Math.min(Math.floor(time / data.period), last - 1));
  const from = k * data.period, to = k + 1 >= last ? data.end : from + data.period;
  const share = to > from ? Math.min((time - from) / (to - from), 1) : 0;
  return (column[k] + share * ((column[k + 1] ?? column[k]) - column[k])) / perUnit;
}

function show(player, time) {
  const {run, data, slider} = player;
  const [x, y, yaw] = ["x", "y", "yaw"].map((name) => at(data, name, time, 1e3));
  place(run.querySelector(".robot.truth"), x, y, yaw);
  let told = time.toFixed(2) + " s of " + data.end.toFixed(2) + " s";
  slider.value = time;
  slider.setAttribute("aria-valuetext", told);
  if (data.ahead) {
    const [ahead, left, turn] = ["ahead", "left", "turn"].map((name) => at(data, name, time, 1e6));
    const c = Math.cos(yaw), s = Math.sin(yaw);
    place(run.querySelector(".robot.estimate"), x + c * ahead - s * left, y + s * ahead + c * left, yaw + turn);
    told += ", estimate " + (100 * Math.hypot(ahead, left)).toFixed(1) + " cm off";
  }
  run.querySelector(".now").textContent = told;
  run.style.setProperty("--at", data.end > 0 ? time / data.end : 0);
}

function place(robot, x, y, yaw) {
  robot.setAttribute("transform", `translate(${x} ${y}) rotate(${(yaw * 180) / Math.PI})`);
}

function play(player) {
  let time = Number(player.slider.value), before = null;
  if (time >= player.data.end) time = 0;
  player.button.textContent = "Pause";
  const step = (now) => {
    if (before !== null) time += ((now - before) / 1000) * Number(player.speed.value);
    before = now;
    show(player, Math.min(time, player.data.end));
    if (time < player.data.end) player.frame = requestAnimationFrame(step);
    else stop(player);
  };
  player.frame = requestAnimationFrame(step);
}

function stop(player) {
  cancelAnimationFrame(player.frame);
  player.frame = 0;
  player.button.textContent = "Play";
}

function choose(id) {
  for (const player of players.values()) {
    if (player.run.id !== id) stop(player);
    player.run.hidden = player.run.id !== id;
  }
  choice.value = id;
}

function follow() {
  const id = decodeURIComponent(location.hash.slice(1));
  if (!players.has(id)) return;
  choose(id);
  document.querySelector("#replay").scrollIntoView();
}

choice.addEventListener("input", () => choose(choice.value));
choice.form.addEventListener("submit", (event) => event.preventDefault());
addEventListener("hashchange", follow);
choose(players.keys().next().value);
follow();
