"""The law that a model is missing, learned from what no known effect explains."""

from hlcs.learning.learn import learn
from hlcs.learning.learned import Learned
