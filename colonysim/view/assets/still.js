// A run that is over and lies in the page itself.

import { start } from "./main.js";
import { unpack } from "./unpack.js";

const data = document.getElementById("data");
unpack(data.textContent).then((run) => {
  data.remove();
  start(run);
});
