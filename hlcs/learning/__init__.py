"""The law that a model is missing, learned from what no known effect explains."""

from hlcs.learning.learned import Learned
from hlcs.learning.missing_law import learn
from hlcs.learning.rebounds import learn_rebounds
