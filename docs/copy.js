/* A button on every block of code copies it: of a session what follows the prompts, without what is printed. */
"use strict";
const code = (block) => {
  const session = [...block.querySelectorAll(".gp")].some((each) => each.textContent.startsWith(">>>"));
  const lines = block.textContent.trimEnd().split("\n");
  const typed = session ? lines.filter((line) => /^(>>>|\.\.\.)( |$)/.test(line)).map((line) => line.slice(4)) : lines;
  return typed.map((line) => line.replace(/^\$ /, "")).join("\n");
};
const copied = async (text) => {
  if (navigator.clipboard) return navigator.clipboard.writeText(text);
  const area = document.body.appendChild(document.createElement("textarea")); // pages read from disk in some browsers
  area.value = text;
  area.select();
  document.execCommand("copy");
  area.remove();
};
document.querySelectorAll("article div.highlight > pre").forEach((block) => {
  if (block.closest(".cell_output, .sphx-glr-script-out")) return;
  const button = document.createElement("button");
  button.className = "copy";
  button.type = "button";
  button.textContent = "Copy";
  button.addEventListener("click", async () => {
    await copied(code(block));
    button.textContent = "Copied";
    setTimeout(() => (button.textContent = "Copy"), 2000);
  });
  block.parentElement.append(button);
});
