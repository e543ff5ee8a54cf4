/* What the theme leaves out for those who hear a page or use no mouse. */
"use strict";
// Names of the two sidebars, and the rank of the headings in them.
document.querySelector(".sidebar-drawer")?.setAttribute("aria-label", "All pages");
document.querySelector(".toc-drawer")?.setAttribute("aria-label", "On this page");
document.querySelectorAll('[role="heading"]:not([aria-level])').forEach((each) => each.setAttribute("aria-level", "2"));
// A formula in a sentence that is wider than the column has a line of its own (custom.css), where it scrolls.
// What scrolls sideways can be reached by the keyboard, also once it is unfolded.
const reachable = () => {
  document.querySelectorAll("article mjx-container:not([display])").forEach((each) => {
    each.classList.remove("wide");
    const around = each.closest("p, li, dd");
    if (around && each.getBoundingClientRect().width > around.clientWidth) each.classList.add("wide");
  });
  document.querySelectorAll("article pre, article .table-wrapper, article .output, mjx-container, div.math").forEach((each) => {
    if (each.scrollWidth > each.clientWidth) each.tabIndex = 0;
  });
};
window.addEventListener("load", () => (window.MathJax?.startup?.promise ?? Promise.resolve()).then(reachable));
window.addEventListener("resize", reachable);
document.addEventListener("toggle", reachable, true);
