"""Results as tables of columns."""

from __future__ import annotations

# The name alone tells type checkers; the module `typing` would delay every worker.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    import pandas as pd


class Table:
    """Result with columns of equal length; `_columns` names them."""

    _columns: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Returns the columns by name; arrays are views of the result."""
        return {name: getattr(self, name) for name in self._columns}

    def to_pandas(self) -> "pd.DataFrame":
        """Returns a DataFrame; columns of several numbers become `tip_0`, `tip_1`, .. .

        Raises:
            ImportError: pandas is not installed.
        """
        import numpy as np
        import pandas as pd

        flat: dict[str, Any] = {}
        for name, value in self.to_dict().items():
            value = np.asarray(value)
            if value.ndim == 1:
                flat[name] = value
            else:
                for index in range(value.shape[1]):
                    flat[f"{name}_{index}"] = value[:, index]
        return pd.DataFrame(flat)

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """Hands the columns to Arrow; needs pandas with pyarrow."""
        return self.to_pandas().__arrow_c_stream__(requested_schema)
