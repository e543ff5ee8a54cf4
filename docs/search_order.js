/* Order of the results of Sphinx's search: pages whose title has the words first, and what shows how before what proves. */
var Scorer = {
  score: ([page, title, , , score]) => {
    const asked = (new URLSearchParams(window.location.search).get("q") || "").toLowerCase().match(/[\p{L}\p{N}_]+/gu) || [];
    const words = title.toLowerCase().match(/[\p{L}\p{N}_]+/gu) || [];
    // A word and its plural: "frequency" and "frequencies" have all but two letters in common.
    const found = asked.filter((each) => words.some((word) => word.startsWith(each.slice(0, Math.max(3, each.length - 2)))));
    const [folder] = page.split("/");
    const place = { start: 3, how_to: 3, gallery: 1, architecture: -3, changelog: -3 }[folder] || 0;
    return score + 5 * found.length + place;
  },
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
