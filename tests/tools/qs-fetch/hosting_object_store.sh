# The rules for object stores of qs-hosting(7) are JSON, of the fields that S3 knows.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs python3
python3 - "$QS_SOURCE/man/qs-hosting.7" << 'CHECK'
import json, re, sys
blocks = re.findall(r"^\.EX\n(.*?)^\.EE", open(sys.argv[1]).read(), re.M | re.S)
policy, cors = (json.loads(block) for block in blocks if block[0] in "{[")
statement = policy["Statement"][0]
print("policy:", sorted(policy), statement["Effect"], statement["Principal"], statement["Action"])
print("cors:", sorted(cors[0]))
CHECK
