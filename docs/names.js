/* Names that the theme does not give, for those who hear a page: its two sidebars, and the rank of their headings. */
"use strict";
document.querySelector(".sidebar-drawer")?.setAttribute("aria-label", "All pages");
document.querySelector(".toc-drawer")?.setAttribute("aria-label", "On this page");
document.querySelectorAll('[role="heading"]:not([aria-level])').forEach((each) => each.setAttribute("aria-level", "2"));
