! What is executed here of what RobotWare has; see prelude.py.
MODULE Prelude
    CONST num pi:=3.14159265;
    CONST num WAIT_MAX:=8388608;
    CONST string stEmpty:="";
    CONST string STR_DIGIT:="0123456789";
    CONST string STR_LOWER:="abcdefghijklmnopqrstuvwxyz";
    CONST string STR_UPPER:="ABCDEFGHIJKLMNOPQRSTUVWXYZ";
    CONST string STR_WHITE:="\09\0A\0B\0C\0D ";
    CONST mecunit ROB_1:=1;
    CONST mecunit ROB_2:=2;
    CONST mecunit ROB_L:=3;
    CONST mecunit ROB_R:=4;
    CONST egmstopmode EGM_STOP_HOLD:=1;
    PERS tooldata tool0:=[TRUE,[[0,0,0],[1,0,0,0]],[0.001,[0,0,0.001],[1,0,0,0],0,0,0]];
    PERS wobjdata wobj0:=[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
    PERS loaddata load0:=[0.001,[0,0,0.001],[1,0,0,0],0,0,0];
    VAR errnum ERRNO;
    VAR intnum INTNO;
    VAR num reg1:=0;
    VAR num reg2:=0;
    VAR num reg3:=0;
    VAR num reg4:=0;
    VAR num reg5:=0;
    VAR clock clock1;

    PROC ClkReset(VAR clock Clock)
    ENDPROC
    PROC ClkStart(VAR clock Clock)
    ENDPROC
    PROC ClkStop(VAR clock Clock)
    ENDPROC
    FUNC num ClkRead(VAR clock Clock)
    ENDFUNC
    PROC WaitTime(\switch InPos, num Time)
    ENDPROC
    PROC WaitUntil(\switch InPos, bool Cond \num MaxTime \VAR bool TimeFlag \num PollRate)
    ENDPROC
    PROC WaitDO(signaldo Signal, num Value \num MaxTime \VAR bool TimeFlag)
    ENDPROC
    PROC WaitSyncTask(\switch InPos, VAR syncident SyncID, PERS tasks TaskList{*} \num TimeOut)
    ENDPROC
    PROC SyncMoveOn(VAR syncident SyncID, PERS tasks TaskList{*} \num TimeOut)
    ENDPROC
    PROC SyncMoveOff(VAR syncident SyncID \num TimeOut)
    ENDPROC
    PROC SyncMoveUndo()
    ENDPROC
    FUNC bool IsSyncMoveOn()
    ENDFUNC
    PROC Stop(\switch NoRegain)
    ENDPROC
    PROC Break()
    ENDPROC

    PROC SocketCreate(VAR socketdev Socket)
    ENDPROC
    PROC SocketBind(VAR socketdev Socket, string LocalAddress, num LocalPort)
    ENDPROC
    PROC SocketConnect(VAR socketdev Socket, string Address, num Port \num Time)
    ENDPROC
    PROC SocketListen(VAR socketdev Socket)
    ENDPROC
    PROC SocketAccept(VAR socketdev Socket, VAR socketdev ClientSocket \INOUT string ClientAddress \num Time)
    ENDPROC
    PROC SocketSend(VAR socketdev Socket \string Str \byte Data{*} \num NoOfBytes)
    ENDPROC
    PROC SocketReceive(VAR socketdev Socket \INOUT string Str | INOUT byte Data{*} \num ReadNoOfBytes \INOUT num NoRecBytes \num Time)
    ENDPROC
    PROC SocketClose(VAR socketdev Socket)
    ENDPROC
    FUNC num SocketPeek(VAR socketdev Socket)
    ENDFUNC

    PROC TPWrite(string String \num Num | bool Bool)
    ENDPROC
    PROC TPErase()
    ENDPROC
    PROC TPReadFK(INOUT num TPAnswer, string TPText, string TPFK1, string TPFK2, string TPFK3, string TPFK4, string TPFK5 \num MaxTime)
    ENDPROC
    PROC SetDO(signaldo Signal, num Value)
    ENDPROC
    PROC Set(signaldo Signal)
    ENDPROC
    PROC Reset(signaldo Signal)
    ENDPROC
    FUNC num DOutput(signaldo Signal)
    ENDFUNC

    PROC MoveAbsJ(jointtarget ToJointPos \identno ID \switch NoEOffs, speeddata Speed \num T, zonedata Zone, PERS tooldata Tool \PERS wobjdata WObj)
    ENDPROC
    PROC MoveJ(robtarget ToPoint \identno ID, speeddata Speed \num T, zonedata Zone, PERS tooldata Tool \PERS wobjdata WObj)
    ENDPROC
    PROC MoveL(robtarget ToPoint \identno ID, speeddata Speed \num T, zonedata Zone, PERS tooldata Tool \PERS wobjdata WObj)
    ENDPROC
    PROC GripLoad(PERS loaddata Load)
    ENDPROC
    PROC StopMove(\switch Quick \switch AllMotionTasks)
    ENDPROC
    PROC StartMove(\switch AllMotionTasks)
    ENDPROC
    PROC StopMoveReset(\switch AllMotionTasks)
    ENDPROC
    PROC ClearPath()
    ENDPROC
    FUNC bool IsStopMoveAct(\switch FromMoveTask | switch FromNonMoveTask)
    ENDFUNC
    FUNC jointtarget CJointT(\string TaskName)
    ENDFUNC
    FUNC robtarget CRobT(\string TaskName \PERS tooldata Tool \PERS wobjdata WObj)
    ENDFUNC
    FUNC robtarget CalcRobT(jointtarget Joint_target, PERS tooldata Tool \PERS wobjdata WObj)
    ENDFUNC
    FUNC jointtarget CalcJointT(robtarget Rob_target, PERS tooldata Tool \PERS wobjdata WObj)
    ENDFUNC
    FUNC robtarget Offs(robtarget Point, num XOffset, num YOffset, num ZOffset)
    ENDFUNC
    FUNC num Distance(pos Point1, pos Point2)
    ENDFUNC

    PROC Hand_Initialize(\num maxSpd \num holdForce \num phyLimit \switch Calibrate)
    ENDPROC
    PROC Hand_MoveTo(num TargetPos \switch NoWait)
    ENDPROC
    PROC Hand_GripInward(\num holdForce \num targetPos \num posAllow \switch NoWait)
    ENDPROC
    PROC Hand_GripOutward(\num holdForce \num targetPos \num posAllow \switch NoWait)
    ENDPROC
    FUNC bool Hand_IsCalibrated()
    ENDFUNC
    FUNC num Hand_GetActualPos()
    ENDFUNC

    PROC EGMReset(INOUT egmident EGMid)
    ENDPROC
    PROC EGMGetId(INOUT egmident EGMid)
    ENDPROC
    PROC EGMSetupUC(mecunit MecUnit, INOUT egmident EGMid, string ExtConfigName, string UCDevice \switch Joint \num CommTimeout)
    ENDPROC
    PROC EGMStreamStart(INOUT egmident EGMid \num SampleRate)
    ENDPROC
    PROC EGMActJoint(INOUT egmident EGMid \PERS dnum DataToSensor{*} \PERS dnum DataFromSensor{*} \egm_minmax J1 \egm_minmax J2 \egm_minmax J3 \egm_minmax J4 \egm_minmax J5 \egm_minmax J6 \egm_minmax J7 \num LpFilter \num SampleRate \num MaxSpeedDeviation)
    ENDPROC
    PROC EGMRunJoint(INOUT egmident EGMid, egmstopmode Mode \switch J1 \switch J2 \switch J3 \switch J4 \switch J5 \switch J6 \switch J7 \num CondTime)
    ENDPROC
    PROC EGMStop(INOUT egmident EGMid, egmstopmode Mode)
    ENDPROC

    PROC ITimer(\switch Single \switch SingleSafe, num Time, INOUT intnum Interrupt)
    ENDPROC
    PROC ISignalDO(\switch Single \switch SingleSafe, signaldo Signal, num TriggValue, INOUT intnum Interrupt)
    ENDPROC
    PROC IDelete(INOUT intnum Interrupt)
    ENDPROC
    PROC ISleep(INOUT intnum Interrupt)
    ENDPROC
    PROC IWatch(INOUT intnum Interrupt)
    ENDPROC
    PROC IDisable()
    ENDPROC
    PROC IEnable()
    ENDPROC

    PROC Incr(INOUT num Name)
    ENDPROC
    PROC Decr(INOUT num Name)
    ENDPROC
    PROC Add(INOUT num Name, num AddValue)
    ENDPROC
    PROC Clear(INOUT num Name)
    ENDPROC
    FUNC num DnumToNum(dnum Value)
    ENDFUNC
    FUNC num Abs(num Value)
    ENDFUNC
    FUNC num Sqrt(num Value)
    ENDFUNC
    FUNC num Pow(num Base, num Exponent)
    ENDFUNC
    FUNC num Round(num Val \num Dec)
    ENDFUNC
    FUNC num Trunc(num Val \num Dec)
    ENDFUNC
    FUNC num Sin(num Angle)
    ENDFUNC
    FUNC num Cos(num Angle)
    ENDFUNC
    FUNC num ATan2(num Y, num X)
    ENDFUNC
    FUNC num Min(num Value1, num Value2)
    ENDFUNC
    FUNC num Max(num Value1, num Value2)
    ENDFUNC
    FUNC byte BitAnd(byte BitData1, byte BitData2)
    ENDFUNC
    FUNC byte BitOr(byte BitData1, byte BitData2)
    ENDFUNC
    FUNC byte BitXOr(byte BitData1, byte BitData2)
    ENDFUNC
    FUNC byte BitLSh(byte BitData, num ShiftSteps)
    ENDFUNC
    FUNC byte BitRSh(byte BitData, num ShiftSteps)
    ENDFUNC
    FUNC string ByteToStr(byte BitData \switch Hex | switch Okt | switch Bin | switch Char)
    ENDFUNC
    FUNC byte StrToByte(string ConStr \switch Hex | switch Okt | switch Bin | switch Char)
    ENDFUNC
    FUNC string NumToStr(num Val, num Dec \switch Exp)
    ENDFUNC
    FUNC bool StrToVal(string Str, INOUT num Val)
    ENDFUNC
    FUNC num StrLen(string Str)
    ENDFUNC
    FUNC num StrFind(string Str, num ChPos, string Set \switch NotInSet)
    ENDFUNC
    FUNC string StrPart(string Str, num ChPos, num Len)
    ENDFUNC
    FUNC num StrMatch(string Str, num ChPos, string Pattern)
    ENDFUNC
    FUNC bool StrMemb(string Str, num ChPos, string Set)
    ENDFUNC
ENDMODULE
