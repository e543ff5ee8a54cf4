/* Sphinx's search asks fetch() for each page found, and Search.htmlToText for its text: both are in page_texts.js. */
"use strict";
window.fetch = async (url) => {
  const root = document.documentElement.dataset.content_root;
  const page = url.slice(root.length).replace(/\.html$/, "");
  return { text: async () => pageTexts[page] };
};
Search.htmlToText = (sections, anchor) => sections[anchor] || Object.values(sections).join(" ");
// The theme's page of results has no heading.
const heading = document.createElement("h1");
heading.textContent = "Search";
document.getElementById("search-results").before(heading);
