cd /tmp/train7; echo 6 > /proc/self/autogroup; export OMP_NUM_THREADS=1 PYTHONPATH=/tmp/train7
exec /tmp/v/bin/python benchmarks/push_seeds.py --seeds 0 1 2 --workers 1 --pushes 100 --work /tmp/pt/seeds7
