"""What the metadata say of the home of a release: its addresses, and README with links to there.

No address stands in the repository. `TVCLIN_HOME` has it where wheel and sdist are built, such as
https://forge.example/tvclin. Without it there are no addresses, and README's links stay as they
are. A wheel that is built from an sdist keeps what the sdist says.
"""

import os
import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface


class Home(MetadataHookInterface):
    """Fills in `readme` and `urls` of `[project]`."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Add both, unless an sdist has them."""
        home, root = os.environ.get("TVCLIN_HOME", "").rstrip("/"), Path(self.root)
        source = (root / "tvclin" / "__init__.py").read_text(encoding="utf-8")
        tag = "v" + re.findall(r'^__version__ = "(.+)"$', source, re.MULTILINE)[0]
        text, urls = (root / "README.md").read_text(encoding="utf-8"), {}
        if home:
            pages = f"{home}/blob/{tag}"
            text = re.sub(r"(!\[[^]]*\]\()(?!https:)", rf"\1{home}/raw/{tag}/", text)
            text = re.sub(r"(?<!!)(\[[^]]*\]\()(?!https:)", rf"\1{pages}/", text)
            urls = {
                "Source": home,
                "Documentation": f"{pages}/docs/index.md",
                "Changelog": f"{pages}/CHANGELOG.md",
                "Issues": f"{home}/issues",
            }
        metadata.setdefault("readme", {"content-type": "text/markdown", "text": text})
        metadata.setdefault("urls", urls)
